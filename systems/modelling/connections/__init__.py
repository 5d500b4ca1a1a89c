"""What is connected in a system: rope ends and seats, signals, and systems inside systems."""
