"""Processes with limits for everything that reads bytes from outside; they die with the server and with the client."""
