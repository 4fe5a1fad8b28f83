#!/usr/bin/env bash
# The two commands on a bare system: tests/systems/bare_system.sh SUITE [--clang] [--demo | --wheel]
#
# Makes the system SUITE (bookworm, trixie, noble) by debootstrap in build/systems, with git and what git needs, clones
# the last commit there and runs tools/demo and tools/test in the clone; ends with their minutes and counts. --clang puts
# clang in place of g++, --demo leaves tools/test out. --wheel tries instead the wheel that tools/wheel made, on
# a system that has python3-venv alone. Exit status: 1 if a command failed, 2 if the system cannot be made.
#
# Needs root, debootstrap and up to 6 GB. Packages come from where this machine's apt takes those of its own distribution;
# of another one from the mirror named by MIRROR, or from debootstrap's. Names, certificates, proxies, apt and pip are set
# up as on this machine. Mounts and processes are in namespaces of their own, which end with this script however it ends.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

cannot() {
  echo "bare_system: $*" >&2
  exit 2
}

case ${1-} in
  bookworm | trixie) distribution=Debian script=sid components=main ;;
  noble) distribution=Ubuntu script=gutsy components=main,universe ;;
  *) cannot "usage: tests/systems/bare_system.sh bookworm|trixie|noble [--clang] [--demo | --wheel]" ;;
esac
suite=$1 name=$1 include=git commands=(demo test) environment=(PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8)
for option in "${@:2}"; do
  case $option in
    --clang) name+=-clang environment+=(CXX=clang++) ;;
    --demo) commands=(demo) ;;
    --wheel) name+=-wheel include=python3-venv commands=(wheel) ;;
    *) cannot "unknown option $option; --clang, --demo and --wheel are allowed" ;;
  esac
done
((EUID == 0)) || cannot "root is needed"
command -v debootstrap >/dev/null || cannot "debootstrap is not installed"

if [[ -z ${INSIDE_NAMESPACES-} ]]; then
  INSIDE_NAMESPACES=1 unshare --mount --pid --fork --kill-child "${BASH_SOURCE[0]}" "$@" &
  trap 'kill -KILL $!' INT TERM  # a gentler signal it would not hear
  status=0
  wait $! || status=$?
  exit $status
fi

root=build/systems/$name
mkdir -p build/systems
rm -rf --one-file-system "$root"

mirror=${MIRROR-}
if [[ -z $mirror ]]; then
  mirror=$(apt-get indextargets --format '$(ORIGIN) $(CODENAME) $(REPO_URI)' 'Created-By: Packages' |
    awk -v origin=$distribution '$1 == origin && $2 !~ /-/ { print $3; exit }')
fi
echo "bare_system: making $name (log: $root.log)"
debootstrap --variant=minbase --include=$include --components=$components "$suite" "$root" "$mirror" $script >"$root.log" 2>&1 || {
  tail -n 5 "$root.log" >&2
  cannot "debootstrap could not make $suite; MIRROR may name another mirror of $distribution"
}

# The machine's own ways to the network.
cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
apt-config dump | grep -E '^Acquire::(http|https|Check|Retries|Force)' >"$root/etc/apt/apt.conf.d/90machine" || true
[[ ! -e /etc/pip.conf ]] || cp /etc/pip.conf "$root/etc/"
mapfile -t -O ${#environment[@]} environment < <(env | grep -E '^(PIP_[A-Z_]+|(http|https|ftp|no)_proxy|(HTTP|HTTPS|NO)_PROXY)=')
if [[ -e /etc/ssl/certs/ca-certificates.crt ]]; then
  cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/machine-certificates.crt"
  environment+=(PIP_CERT=/etc/machine-certificates.crt)
fi

mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
inside() { chroot "$root" env -i "${environment[@]}" bash -c "$1" </dev/null; }

if [[ $name == *-clang ]]; then
  inside 'apt-get -q update && apt-get -qy install --no-install-recommends clang' >>"$root.log" 2>&1 || {
    tail -n 5 "$root.log" >&2
    cannot "apt-get could not install clang"
  }
fi
[[ -z $(git status --porcelain) ]] || echo "bare_system: what is not committed is left out"
git clone --quiet --no-hardlinks . "$root/root/polhode"

status=0 summary=()
for command in "${commands[@]}"; do
  what=tools/$command run="cd /root/polhode && tools/$command"
  if [[ $command == wheel ]]; then
    cp -r build/wheel/dist "$root/root/dist"
    run="python3 -m venv /root/venv && /root/venv/bin/pip install -q numpy scipy &&
      /root/venv/bin/pip install -q --no-index --find-links /root/dist polhode &&
      /root/polhode/tests/systems/try_package.sh /root/venv /root/polhode"
  fi
  echo "bare_system: $what (log: $root-$command.log)"
  began=$SECONDS result=succeeded
  inside "$run" >"$root-$command.log" 2>&1 || {
    result=FAILED status=1
    tail -n 20 "$root-$command.log"
  }
  counts=$(grep -E '^[0-9]+ passed, [0-9]+ failed' "$root-$command.log" | tail -n 1 || true)
  summary+=("$(printf '%-16s %s %s in %d min %02d s%s' "$name" "$what" "$result" $(((SECONDS - began) / 60)) \
    $(((SECONDS - began) % 60)) "${counts:+: $counts}")")
done
printf '%s\n' "${summary[@]}"
exit $status
