"""Closest points on limit surfaces and on their boundary and crease curves."""
