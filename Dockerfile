# Programs and library, built on Debian 12. Without a command the image maps the log of the demonstration into ./demo:
#   docker build -t hybrid . && docker run --rm -v "$PWD:/data" hybrid
#   docker run --rm -v "$PWD:/data" hybrid hybrid-replay my.rawlog --report -o out
FROM debian:12
COPY . /src/hybrid
WORKDIR /src/hybrid
RUN apt-get update && scripts/setup --build && cmake --preset release -DHYBRID_BUILD_TESTS=OFF \
    -DHYBRID_BUILD_BENCH=OFF && cmake --build --preset release && cmake --install build/release --prefix /usr/local
WORKDIR /data
CMD ["hybrid-replay", "-c", "/usr/local/share/hybrid/config/classed_demo.ini", "--report", "-o", "demo"]
