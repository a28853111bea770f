"""A run as one web page with a time slider: no network, no dependencies, nothing to install.

`write_player`   the page of a history
"""

from oblique_impact.renders.player.document import write_player

__all__ = ["write_player"]
