"""Questions on this mechanics whose quick answer is wrong: the page docs/which-way.md."""
