#!/usr/bin/env bash
# Installs what berm is built from and runs on, from Debian 12 (bookworm); nothing if it is all there.
set -euo pipefail

packages=(
  g++ cmake ninja-build ccache pkg-config                      # build
  libpetsc-real-dev                                            # solvers; brings MPI and MUMPS
  libopenblas-pthread-dev                                      # the BLAS that comes by default is several times slower
  libeigen3-dev libfmt-dev libcli11-dev                        # small tensors, text, command line
  libtomlplusplus-dev libmuparser-dev                          # case files, expressions in them
  libgmsh-dev libboost-dev zlib1g-dev                          # meshes, geometry, VTK files
  openmpi-bin libopenmpi-dev libtrilinos-zoltan-dev libhdf5-openmpi-dev   # processes, their shares, checkpoints
  libgtest-dev                                                 # tests
  python3 python3-numpy python3-matplotlib python3-vtk9        # report
)

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "This is not Debian: install what corresponds to these packages of Debian 12, then go on with README.md, \"By hand\":" >&2
  echo "  ${packages[*]}" >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)
  [[ $status == installed ]] || missing+=("$package")
done
((${#missing[@]})) || exit 0

root=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null; then
    echo "Missing: ${missing[*]}" >&2
    echo "Run as root: apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 1
  fi
  root=(sudo)
fi
apt=("${root[@]}" env DEBIAN_FRONTEND="${DEBIAN_FRONTEND:-noninteractive}" apt-get)

echo "Installing: ${missing[*]}"
"${apt[@]}" -q update || echo "The package lists could not be renewed; trying with the old ones." >&2
if ! "${apt[@]}" -q install -y --no-install-recommends "${missing[@]}"; then
  echo "These Debian packages could not be installed (is there a network connection?): ${missing[*]}" >&2
  echo "When there is: apt-get install --no-install-recommends ${missing[*]}" >&2
  exit 1
fi
