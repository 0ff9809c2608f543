% The chain in Octave as users of ode45 write it: vectorised force, default options but for the two tolerances.
% ke (file) reads rows [N zeta K mass V c2 c3 t_end RelTol AbsTol] and prints for each
% max |v_mid| of the bistable chain, of the linear chain, and the processor seconds that both took.
1;

function dy = derivative (y, N, zeta, c2, c3, K, mass)
  n = N + 1;
  u = y(1:n);  v = y(n+1:end);
  e = diff ([u(2:end); 0]);
  m = min (e, 0);
  g = e + m .* m .* (c2 + c3 * m) + (2 * zeta) * diff ([v(2:end); 0]);
  F = K * max (u(1) - u(2), 0) ^ 1.5;
  dy = [v; -F / mass; diff([-F; g])];
endfunction

% The maximum over continuous time: ode45 returns its steps only (Octave ignores Refine), so the crests are those of
% the cubic through both ends of each step.
function best = peak_speed (t, y, N, zeta, c2, c3)
  mid = N + 1 + floor ((N + 1) / 2) + 1;
  k = mid - N - 1;
  last = (k == N + 1);
  u = y(:, k-1:min (k+1, N+1));  v = y(:, N+1+(k-1:min (k+1, N+1)));
  if (last)  u(:, 3) = 0;  v(:, 3) = 0;  endif
  e = diff (u, 1, 2);
  m = min (e, 0);
  a = diff (e + m .* m .* (c2 + c3 * m) + 2 * zeta * diff (v, 1, 2), 1, 2);
  h = diff (t);
  v0 = v(1:end-1, 2);  v1 = v(2:end, 2);
  b = v0 + h .* a(1:end-1) / 3;  c = v1 - h .* a(2:end) / 3;
  p = b - v0;  q = c - b;  r = v1 - c;
  root = sqrt (max (q .* q - p .* r, 0));
  best = max (abs (v(:, 2)));
  for x = [p ./ (p - q - root), p ./ (p - q + root)]
    x(! (x > 0 & x < 1)) = 0;
    w = 1 - x;
    best = max (best, max (abs (w.^3 .* v0 + 3 * x .* w.^2 .* b + 3 * x.^2 .* w .* c + x.^3 .* v1)));
  endfor
endfunction

function best = one_chain (N, zeta, c2, c3, K, mass, V, t_end, options)
  y = zeros (2 * (N + 1), 1);
  y(N + 2) = V;
  [t, y] = ode45 (@(t, y) derivative (y, N, zeta, c2, c3, K, mass), [0, t_end], y, options);
  best = peak_speed (t, y, N, zeta, c2, c3);
endfunction

function ke (file)
  for row = load (file).'
    [N, zeta, K, mass, V, c2, c3, t_end, rtol, atol] = num2cell (row){:};
    options = odeset ("RelTol", rtol, "AbsTol", atol);
    start = cputime ();
    bistable = one_chain (N, zeta, c2, c3, K, mass, V, t_end, options);
    linear = one_chain (N, zeta, 0, 0, K, mass, V, t_end, options);
    printf ("%.17g %.17g %.6f\n", bistable, linear, cputime () - start);
  endfor
endfunction

ke (argv (){end});
