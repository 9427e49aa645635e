"""Texts at the top and the end of the page: findings, comparability, definitions, reproduction."""
