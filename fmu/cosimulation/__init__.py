"""FMUs and systems coupled by a master."""
