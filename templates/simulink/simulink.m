% {{ name }}_simulink: the functions of {{ name }}.h as C Caller blocks of Simulink.
%   {{ name }}_simulink() writes the library {{ name }}_blocks into the current folder.
%   {{ name }}_simulink('NAME') sets the custom code of a loaded model, for C Caller blocks that it has.
% Matrices leave a block as vectors, row by row. A function with a status has one more output: 0 is
% success. The settings hold the path of this folder: run it again if the folder moves.
% It was checked in Octave with stand-ins for new_system, add_block and set_param, not in Simulink.
function {{ name }}_simulink(model)
  if nargin > 0
    set_custom_code(model);
    set_param(model, 'RTWUseSimCustomCode', 'on');
    return
  end
  library = '{{ name }}_blocks';
  load_system('simulink');
  if bdIsLoaded(library)
    close_system(library, 0);
  end
  new_system(library, 'Library');
  set_custom_code(library);
  set_param(library, 'SimUseLocalCustomCode', 'on');
{% for k in kernels %}
  add_caller(library, {{ loop.index }}, '{{ k.name }}', { {% for a in k.arguments if a.written %}'{{ a.name }}', '{{ "InputOutput" if a.read else "Output" }}', {% endfor %}});
{% endfor %}
{% if values %}
  add_block('simulink/Sources/Constant', [library '/X'], 'Position', place({{ kernels|length + 1 }}), ...
    'OutDataTypeStr', '{{ "double" if dtype == "double" else "single" }}', 'Value', '[{% for value in values.X %}{{ value }}; {% endfor %}]');
{% endif %}
  save_system(library);
end

% The sources of the functions, and their header, from this folder.
function set_custom_code(model)
  here = fileparts(mfilename('fullpath'));
  sources = { ...
{% for k in kernels %}
    '{{ name }}_{{ k.name }}.c', ...
{% endfor %}
  };
  set_param(model, 'SimCustomHeaderCode', '#include "{{ name }}.h"');
  set_param(model, 'SimUserIncludeDirs', ['"' here '"']);
  set_param(model, 'SimUserSources', strjoin(sources, sprintf('\n')));
end

% One block. scopes has pairs: the argument that the function writes, and its scope.
function add_caller(library, number, kernel, scopes)
  block = [library '/' kernel];
  add_block('simulink/User-Defined Functions/C Caller', block, 'Position', place(number));
  set_param(block, 'FunctionName', ['{{ name }}_' kernel]);
  ports = get_param(block, 'FunctionPortSpecification');
  for i = 1:numel(ports.InputArguments)
    at = find(strcmp(ports.InputArguments(i).Name, scopes(1:2:end)));
    if ~isempty(at)
      ports.InputArguments(i).Scope = scopes{2 * at};
    end
  end
end

% Left, top, right and bottom of a block: four in a row.
function position = place(number)
  left = 40 + 280 * mod(number - 1, 4);
  top = 40 + 160 * floor((number - 1) / 4);
  position = [left, top, left + 200, top + 100];
end
