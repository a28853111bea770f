"""The paper's figures and claims from our own runs (Yuan, Li, Zhang, Hong, Acta Mechanica Sinica 32(4), 2016).

`cases`     what is simulated: the paper's case, the choices that it leaves open, scenarios that stick
`measures`  numbers from runs that differ in their friction model
`claims`    31 claims, each with the rule by which it is judged
`sticking`  why the tip can or cannot stick
`figures`   figures 2 to 16, and slip velocities beside the ratios that sticking would need
`report`    the page and the tables
`command`   `reproduce`: all of it
"""
