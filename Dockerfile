# Runs `make compare` as an ordinary user, on the versions of constraints.txt:
#   docker build --tag indoor-explorers .
#   docker run --name compared indoor-explorers && docker cp compared:/indoor-explorers/results .
FROM python:3.11-slim

RUN apt-get update \
    && apt-get install --yes --no-install-recommends git make \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --create-home explorer \
    && install --directory --owner explorer /indoor-explorers

USER explorer
WORKDIR /indoor-explorers
COPY --chown=explorer:explorer . .
RUN make .venv/.installed-compare

CMD ["make", "compare"]
