"""Static pictures, painted without a display, a graphics card or matplotlib's global state."""
