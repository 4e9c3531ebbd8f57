#!/bin/sh
set -e
if command -v py3clean >/dev/null; then
  py3clean -p python3-flexopt
fi
