"""C code and its manifest

symgen writes a robot as C code with a manifest. The manifest says which parameters the code takes
and what a call costs.
"""

# ## The package
# A package is a set of named files. `symgen.write_package` would write them into a folder.

import json

import symgen

model = symgen.derive("panda", ("energy_regressor", "friction_power", "inverse_dynamics"))
package = symgen.generate(model, target="c")
sources = sorted(name for name in package.files if name.endswith(".c"))
print("\n".join(sources))

# ## The manifest
# It lists each kernel with its inputs, outputs and operations, and the base parameters as formulas.

manifest = json.loads(package.files["manifest.json"])
for kernel in manifest["kernels"]:
    inputs = ", ".join(f"{x['name']} {x['shape']}" for x in kernel["inputs"])
    print(f"{kernel['name']}({inputs}): {kernel['operations']['mul']} multiplications")
parameter = manifest["base_parameters"][0]
print(f"{parameter['name']} = {parameter['expression']} in {parameter['unit']}")

# ## The proof
# The manifest also holds the rank that proves the number of parameters.

rank = manifest["proof"]["rank"]
print(f"rank {rank} of {len(manifest['standard_names'])} standard parameters")
assert rank == len(manifest["base_parameters"]) == 62
