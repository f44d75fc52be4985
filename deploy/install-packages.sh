#!/usr/bin/env bash
# Installs the Debian 12 packages that Coppice needs, those that are missing only.
#   deploy/install-packages.sh           to build and run
#   deploy/install-packages.sh tests     also to test: hosts made of network namespaces, certificates, wrong clocks
#   deploy/install-packages.sh page      also to test the page of report and studio in a browser (Node 20 is not in Debian 12)
#   deploy/install-packages.sh slurm     also to test deploy/slurm
#   deploy/install-packages.sh format    also for clang-format
#   deploy/install-packages.sh lint      also for clang-tidy and fuzzing
#   deploy/install-packages.sh package   also to make the Debian package
set -euo pipefail

packages=(g++ cmake ninja-build mold cyclonedds-dev cyclonedds-tools libcli11-dev
  libtomlplusplus-dev libsqlitecpp-dev libsqlite3-dev libspdlog-dev libfmt-dev nlohmann-json3-dev libexpected-dev
  libxxhash-dev libtinyxml2-dev libmicrohttpd-dev prometheus-cpp-dev libeigen3-dev libsuitesparse-dev libssl-dev openssl graphviz gnuplot-nox)
for group in "$@"; do
  case $group in
    tests) packages+=(libgtest-dev iproute2 nftables ethtool faketime python3-venv python3-prometheus-client) ;;
    page) packages+=(chromium fonts-dejavu-core) ;;
    slurm) packages+=(slurm-wlm) ;;
    format) packages+=(clang-format-14) ;;
    lint) packages+=(clang-tidy-19 clang-19 libclang-rt-19-dev) ;;
    package) packages+=(dpkg-dev file help2man) ;;
    *) echo "deploy/install-packages.sh: no group '$group': expected tests, page, slurm, format, lint or package" >&2; exit 2 ;;
  esac
done

missing=()
for package in "${packages[@]}"; do
  if [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null || true)" != installed ]; then
    missing+=("$package")
  fi
done
if [ ${#missing[@]} -eq 0 ]; then
  exit 0
fi

root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "Run as root, or install: ${missing[*]}" >&2; exit 1; }
  root=(sudo)
fi
echo "Installing ${missing[*]}"
"${root[@]}" apt-get update -qq
"${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
