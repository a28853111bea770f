"""The paper's figures and claims from our own runs (Yuan, Li, Zhang, Hong, Acta Mechanica Sinica 32(4), 2016).

`cases`      what is simulated: the paper's case, what it leaves unsaid, the scenarios that stick
`runs`       a run without what varies along the beam: light, sent between processes
`sticking`   the sticking solution along a contact: why the tip can or cannot stick
`measures`   the numbers that claims are judged by
`claims`     what a claim and a verdict are; `forces`, `energies`, `motions` hold the rules
`unsaid`     the effect of each choice that the paper leaves open
`pictures`   figures 2 to 16; `diagrams` those about choices, robustness and sticking
`material`   all of it; `pages` and `stick_pages` the report, `tables` its data; `command` the command
"""
