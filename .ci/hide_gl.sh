#!/bin/bash
# Run "$@" where no GL, X11 or network exists, only loopback.
# Needs root or user namespaces, unshare (util-linux) and ip (iproute2); says so if it cannot hide.
set -euo pipefail
export PATH="$PATH:/usr/sbin:/sbin"

if [ "${1:-}" != --inside ]; then
    flags=(--mount --net --propagation private)
    unshare "${flags[@]}" true 2>/dev/null || flags=(--user --map-root-user "${flags[@]}")
    unshare "${flags[@]}" true || {
        echo "hide_gl.sh: needs root or user namespaces to hide GL and the network" >&2
        exit 1
    }
    exec unshare "${flags[@]}" "$0" --inside "$@"
fi

shift
ip link set lo up
folders=$(ldconfig -p | sed -n 's/.*=> \(.*\)\/[^/]*$/\1/p' | sort -u)
for name in libGL libEGL libOSMesa libX11 libxcb libgbm libvulkan libglapi libdrm; do
    # shellcheck disable=SC2086 # one folder per word
    find $folders -maxdepth 1 -name "$name*.so*" 2>/dev/null || true
done | while read -r library; do
    mount --bind /dev/null "$library"
done
if [ -d /dev/dri ]; then
    mount -t tmpfs none /dev/dri
fi
unset DISPLAY WAYLAND_DISPLAY
exec "$@"
