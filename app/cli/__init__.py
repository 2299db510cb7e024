"""The command line: the engine's commands, and those of the review tool."""
