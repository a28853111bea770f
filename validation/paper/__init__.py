"""The paper's figures and claims from our runs (Yuan, Li, Zhang, Hong, Acta Mechanica Sinica 32(4), 2016).

`claims.toml` is the table of the claims, `claims` holds the rules that judge them; `command` is `reproduce`.
"""
