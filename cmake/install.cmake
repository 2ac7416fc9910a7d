# `cmake --install` puts libraries, headers (under include/hybrid-<version>, with the repository's own paths),
# apps and a package file, so that find_package(hybrid) gives hybrid::hybrid and hybrid::mrpt.
