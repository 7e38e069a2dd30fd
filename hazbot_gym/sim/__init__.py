"""The mutable world: drive, people, sensors and contacts."""
