"""One module a section of the paper; each has ``chapter(quick) -> Chapter``."""
