"""The pictures, one module a section of the paper: what experiments found, as SVG."""
