#!/usr/bin/env bash
# Builds the page into OUT, that of reports into REPORT, working in WORK: the sources stay clean. Without npm or without its registry there is no page,
# which is said and is no error; everything else works without it.
# usage: build.sh OUT REPORT WORK
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
out=$1 report=$2 work=$3
without() {
  echo "gw-view: $1: its page is not built; gw-view says so to browsers, and serves viewers all the same; reports have their plain form" >&2
  exit 0
}
command -v npm >/dev/null || without "npm is missing"
mkdir -p "$work"
rm -rf "$work/src"
cp -r "$here/src" "$here/index.html" "$here/report.html" "$here/vite.config.js" "$here/package.json" "$work"
# Packages again only when the lock file changed.
if ! cmp -s "$here/package-lock.json" "$work/installed.json"; then
  cp "$here/package-lock.json" "$work"
  (cd "$work" && npm ci --no-audit --no-fund --fetch-retries=1 --fetch-timeout=30000 --loglevel=error >&2) ||
    without "npm could not install the packages (network?)"
  cp "$here/package-lock.json" "$work/installed.json"
fi
(cd "$work" && npx --no-install vite build --logLevel warn --emptyOutDir --outDir "$out" >&2)
(cd "$work" && npx --no-install vite build --logLevel warn --mode report --emptyOutDir --outDir "$report" >&2)
