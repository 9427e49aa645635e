"""What is flown: experiments, the selection of policies and scenarios, provenance."""
