"""The paper's figures and claims from our runs (Yuan, Li, Zhang, Hong, Acta Mechanica Sinica 32(4), 2016).

`measures` runs and measures, `rules` holds the claims with what judges them; `command` is `reproduce`.
"""
