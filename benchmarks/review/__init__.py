"""The review tool timed as a user meets it: a real server, a real browser, a real drive."""
