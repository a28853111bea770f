"""Keys of a scenario found from measured data: `measured`, then `least_squares`, `intervals`, and all in `fit`."""
