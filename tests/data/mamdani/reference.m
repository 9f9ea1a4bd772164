% Reference outputs of the Mamdani systems here and in ../fis-corpus, by Octave's fuzzy-logic-toolkit.
%   octave-cli --quiet reference.m INTO
% A line of a file: the inputs; the outputs where the method of defuzzification is not the centroid or the bisector,
% else the sums of mu and of mu * x over 101 points of each output's joint set. (The toolkit integrates its centroid by
% trapezoids, its bisector is the number of a point, and probor is called algebraic_sum.)
1;
function tabulate (fis, points, name)
  found = [];
  for k = 1:rows (points)
    x = points(k, :);
    [output, ~, ~, joint] = evalfis (x, fis, 101);
    values = [];
    for j = 1:columns (joint)
      range = fis.output(j).range;
      places = linspace (range(1), range(2), 101)';
      if (any (strcmp (fis.defuzzMethod, {'centroid', 'bisector'})))
        values = [values, sum(joint(:, j)), sum(joint(:, j) .* places)];
      else
        values = [values, output(j)];
      endif
    endfor
    found = [found; x, values];
  endfor
  dlmwrite (name, found, 'delimiter', ',', 'precision', '%.17g');
endfunction
pkg load fuzzy-logic-toolkit
here = fileparts (mfilename ('fullpath'));
into = argv (){end};
fis = readfis (fullfile (here, 'brake.fis'));
[a, b] = ndgrid (linspace (0, 10, 6), linspace (-1, 3, 5));
points = [a(:), b(:)] + 0.01 * [cos(1:30)', 0 * (1:30)'];
points = max (points, [0, -1]);
points = min (points, [10, 3]);
methods = {'min', 'max', 'min', 'max', 'centroid'; 'prod', 'algebraic_sum', 'prod', 'sum', 'centroid'; ...
           'min', 'algebraic_sum', 'prod', 'algebraic_sum', 'centroid'; 'prod', 'max', 'min', 'sum', 'bisector'; ...
           'min', 'max', 'min', 'max', 'mom'; 'prod', 'algebraic_sum', 'min', 'max', 'lom'; ...
           'min', 'max', 'min', 'max', 'som'};
for m = 1:size (methods, 1)
  fis.andMethod = methods{m, 1};
  fis.orMethod = methods{m, 2};
  fis.impMethod = methods{m, 3};
  fis.aggMethod = methods{m, 4};
  fis.defuzzMethod = methods{m, 5};
  tabulate (fis, points, fullfile (into, ['brake-' strrep(strjoin(methods(m, :), '-'), 'algebraic_sum', 'probor') '.csv']));
endfor
fis = readfis (fullfile (here, '..', 'fis-corpus', 'm05_kzafeiroudi_smf.fis'));
[a, b] = ndgrid (linspace (0, 400, 7), linspace (0, 180, 5));
tabulate (fis, [a(:), b(:)], fullfile (into, 'm05_kzafeiroudi_smf.csv'));
