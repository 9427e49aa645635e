"""The report: one self-contained page, and figures for print."""
