% {{ name }}_build: compile {{ name }}_mex in the current folder, with MATLAB's mex or Octave's (octave-dev).
%   tau = {{ name }}_mex('inverse_dynamics', q, qd, qdd, X)   one sample: vectors; N samples: rows
function {{ name }}_build()
  here = fileparts(mfilename('fullpath'));
  package = fileparts(here);
  names = { ...
{% for k in kernels %}
    '{{ name }}_{{ k.name }}.c', ...
{% endfor %}
  };
  sources = cellfun(@(name) fullfile(package, name), names, 'UniformOutput', false);
  gateway = fullfile(here, '{{ name }}_mex.c');
  mex('-output', '{{ name }}_mex', ['-I' package], gateway, sources{:});
end
