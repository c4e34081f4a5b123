"""Subdivision curves, fitted to boundaries and features."""
