#!/usr/bin/env bash
# idf-component-manager 3.1.2: `compote manifest lint` accepts a manifest with misspelt keys.
#
# The schema of idf_component.yml has a fixed set of keys at the top level. The linter reports a wrong version, but a
# key that the schema does not have passes without a word, exit code 0. A component whose "targets" is
# misspelt is then offered for every chip, and one whose "dependencies" is misspelt is built without them.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install -q idf-component-manager==3.1.2
lint() {
  mkdir -p "$folder/component"
  printf '%b' "$1" >"$folder/component/idf_component.yml"
  code=0
  (cd "$folder/component" && "$folder/env/bin/compote" manifest lint >"$folder/out" 2>&1) || code=$?
  echo "exit code $code: $(printf '%b' "$1" | tr '\n' ';')"
}
lint 'version: "1.0.0"\ntargets: [esp32]\n'
[ "$code" = 0 ]
lint 'version: "one"\n'
[ "$code" != 0 ] # the linter does look at the values of known keys
lint 'version: "1.0.0"\ntarget: [esp32]\ndependancies: {idf: ">=5.0"}\n'
[ "$code" = 0 ] || { echo "misspelt keys are refused now"; exit 1; }
