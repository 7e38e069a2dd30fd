"""General helpers: files, provenance, terminal, YAML, checksums, processors."""
