"""Tests of pictures, films, pages and exports."""

#: built-in scenarios that differ in what is drawn
FAMILIES = {
    "paper": ("paper",),
    "mid-span": ("mid-span",),
    "hub": ("paper", "root.kind=hub", "root.inertia=0.1", "root.hub_radius=0.1", "contact.enabled=false"),
    "tapered": ("tapered", "end_time=0.34"),
}
