# The locked environment on a small Linux.
#   docker build -t skewbridge .
#   docker run --rm -v "$PWD/results:/home/skewbridge/study/results" skewbridge
# runs make smoke; the folder of results must be writable for user 1000.
# For `snakemake --software-deployment-method apptainer` (workflow/Snakefile):
#   apptainer build skewbridge.sif docker-daemon:skewbridge:latest
FROM python:3.12-slim

# make for the targets, git for the commit in the provenance.
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends make git \
    && rm -rf /var/lib/apt/lists/* \
    && useradd --create-home --uid 1000 skewbridge
USER 1000
WORKDIR /home/skewbridge/study
COPY --chown=1000 . .
# Compiled here, because Python cannot write into an image.
RUN UV_COMPILE_BYTECODE=1 make setup
ENV PATH=/home/skewbridge/study/.venv/bin:$PATH MPLCONFIGDIR=/tmp/matplotlib
CMD ["make", "smoke"]
