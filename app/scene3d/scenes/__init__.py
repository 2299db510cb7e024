"""The three scenes, drawn with viser; independent of servers, pages and routes."""
