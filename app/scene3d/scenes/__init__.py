"""The three scenes, drawn into a viser scene; nothing here knows of servers, pages or routes."""
