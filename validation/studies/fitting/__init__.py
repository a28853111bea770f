"""Keys of a scenario found from measured data, in the order in which it is done.

`measured`       the data: a CSV file with units, and what a run says of each value
`least_squares`  the keys that are fitted, residuals and their derivatives, least squares from several starts
`intervals`      95 % intervals from the Jacobian and profiles, correlations, and what stands against the result
`fit`            all of it in one call, lines for a terminal, the page
"""
