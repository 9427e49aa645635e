"""The top and the end of the page: findings, comparability, definitions, reproduction."""
