"""What results say: comparisons of policies, tables, panels, notes and verdicts, for pages, exports and terminals."""
