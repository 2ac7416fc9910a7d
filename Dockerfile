# Programs and library, built on Debian 12: docker build -t hybrid . && docker run --rm hybrid hybrid-replay --help
FROM debian:12
COPY . /src/hybrid
WORKDIR /src/hybrid
RUN apt-get update && scripts/setup && cmake --preset release -DHYBRID_BUILD_TESTS=OFF \
    -DHYBRID_BUILD_BENCH=OFF && cmake --build --preset release && cmake --install build/release --prefix /usr/local
WORKDIR /data
