# The command b2b and the Python package, on a processor.
#
#   docker build --tag b2b .
#   docker run --rm --volume "$PWD:/work" --user "$(id -u):$(id -g)" b2b run OfficeSmall --period 01-01..01-03

FROM rust:1.95-slim-bookworm AS build
RUN apt-get update \
 && apt-get install --yes --no-install-recommends python3-venv \
 && rm -rf /var/lib/apt/lists/* \
 && python3 -m venv /maturin \
 && /maturin/bin/pip install --no-cache-dir 'maturin>=1.9,<2'
WORKDIR /source
COPY . .
RUN /maturin/bin/maturin build --release --out /wheels

FROM python:3.12-slim-bookworm
RUN --mount=type=bind,from=build,source=/wheels,target=/wheels \
    pip install --no-cache-dir /wheels/*.whl \
 && useradd --create-home b2b \
 && install --directory --mode 777 /work /cache
# Any user may run the image.
ENV B2B_CACHE=/cache
USER b2b
WORKDIR /work
ENTRYPOINT ["b2b"]
CMD ["--help"]
