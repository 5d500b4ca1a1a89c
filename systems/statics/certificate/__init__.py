"""The certificate of a solved state: an independent check of spans, loads, sheave laws and stability."""
