"""Control sheaves: responses tuned, schedules optimised."""
