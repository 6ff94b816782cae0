#!/usr/bin/env bash
# Installs the packages in packages.txt that this machine lacks, and prints their names. It is for Debian 12 and uses sudo unless it
# is run by root. With --long it also installs the packages on the lines that begin with "long:".
set -euo pipefail
cd "$(dirname "$0")"
lines=$(grep -v '^long:' packages.txt)
[ "${1:-}" != "--long" ] || lines=$(sed 's/^long://' packages.txt)
read -r -d '' -a wanted <<< "$lines" || true

if ! command -v apt-get > /dev/null; then
    echo "This is not Debian: the packages that packages.txt names have to be installed already." >&2
    exit 0
fi
missing=()
for package in "${wanted[@]}"; do
    dpkg-query -W -f='${Status}' "$package" 2> /dev/null | grep -q 'ok installed' || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo > /dev/null || { echo "Run as root, or install: ${missing[*]}" >&2; exit 1; }
    as_root=(sudo)
fi
echo "Installing from Debian: ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" > /dev/null
