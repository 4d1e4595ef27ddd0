#!/usr/bin/env bash
# The README's two commands as a stranger would type them: a fresh clone, an empty home, and nothing on the
# path but python3 (with venv and pip), git, make and what a shell needs. No uv, no packages.
#
#   tests/bare_environment.sh            make walk, then make test
#   tests/bare_environment.sh walk       only the first
#
# Says how long each took. The clone goes into a temporary folder, which is removed.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/bin" "$work/home" "$work/tmp"

# the interpreter itself, not a wrapper that needs a path of its own
python=$("${PYTHON:-python3}" -c 'import sys; print(sys.executable)')
for name in python3 git make bash sh env grep sed expand cat cp mv rm mkdir rmdir ls ln touch chmod uname \
        dirname basename tr sort head tail wc date sleep test true false stty tput id hostname; do
    path=$(command -v "$name" 2>/dev/null) || continue
    [ "$name" = python3 ] && path=$python
    [ -x "$path" ] && ln -s "$path" "$work/bin/$name"
done
"$python" -c 'import venv, ensurepip' || { echo "python3 has no venv or no pip; on Debian: apt-get install python3-venv"; exit 2; }

bare() {
    # how a computer reaches its package index (pip's own settings, proxies) is not part of the environment
    local keep=()
    for name in PIP_INDEX_URL PIP_EXTRA_INDEX_URL PIP_CERT PIP_CONFIG_FILE SSL_CERT_FILE REQUESTS_CA_BUNDLE \
            http_proxy https_proxy no_proxy HTTP_PROXY HTTPS_PROXY NO_PROXY; do
        [ -n "${!name:-}" ] && keep+=("$name=${!name}")
    done
    env -i "${keep[@]}" PATH="$work/bin" HOME="$work/home" TMPDIR="$work/tmp" LANG=C.UTF-8 TERM=dumb "$@"
}

git clone --quiet --no-hardlinks "$here" "$work/bigant"
cd "$work/bigant"
for program in uv pip; do
    if bare sh -c "command -v $program" >/dev/null 2>&1; then echo "$program is on the path: not bare"; exit 2; fi
done
for target in ${1:-walk test}; do
    begin=$(date +%s)
    bare make "$target"
    echo "make $target: good after $(($(date +%s) - begin)) s"
done
[ -s runs/first_walk.html ] || [ "${1:-walk}" = test ] || { echo "make walk drew nothing"; exit 1; }
left=$(git status --porcelain)
[ -z "$left" ] || { echo "files were left that git does not ignore:"; echo "$left"; exit 1; }
