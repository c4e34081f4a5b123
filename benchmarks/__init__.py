"""Measurements on real models; ``python -m benchmarks`` prints the tables of docs/benchmarks.md."""
