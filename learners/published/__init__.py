"""Published exploration networks, flown in this world from a user's clone of their repositories.

ARiADNE (Cao et al., ICRA 2023, arXiv:2301.11575), IR2 (Tan et al., IROS 2024, arXiv:2409.04730) and MARVEL (Chiun et
al., ICRA 2025, arXiv:2502.20217). The modules are written from the papers and from what the released code computes, and
share no code with it. ``policy`` has the policies; ``ariadne``, ``ir2`` (with ``routes``) and ``marvel`` make what the
networks see, on ``lattice`` and ``sighted``; ``checkpoint`` reads the weights, and ``network`` computes.
"""
