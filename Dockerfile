# The command with Debian's SUMO.
#
#   docker build -t tsc-family .
#   docker run --rm -v "$PWD:/work" tsc-family run smoke --out results/smoke
#
# Without arguments it runs the small evaluation of `make demo`.
FROM rust:1-bookworm AS build
WORKDIR /src
COPY . .
RUN scripts/setup.sh && cargo build --release

FROM debian:bookworm-slim
COPY scripts/setup.sh /tmp/setup.sh
RUN /tmp/setup.sh --run && rm -rf /tmp/setup.sh /var/lib/apt/lists/*
COPY --from=build /src/target/release/tsc-family /usr/local/bin/tsc-family
WORKDIR /work
ENTRYPOINT ["tsc-family"]
CMD ["run", "salt-lake-city", "--budget", "6", "--eval-seeds", "3", "--out", "results/demo"]
