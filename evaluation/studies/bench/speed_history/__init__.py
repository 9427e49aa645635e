"""The benchmarks of ``bench`` for asv (airspeed velocity), which runs them over commits; see ``asv.conf.json``."""
