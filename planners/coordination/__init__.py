"""Who explores what: how planners of a team share the frontier under limited radio."""
