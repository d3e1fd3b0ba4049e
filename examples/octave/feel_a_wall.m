% Pushes the emulated knob into a wall, from Octave or MATLAB, through torsio_mex.c.
torsio_mex('open', 'emulated');
torsio_mex('wall', 0.1, 1.4);
torsio_mex('push', [0, 0; 1, 0.05]);  % ever harder, up to 50 mN m
torsio_mex('arm');
log = torsio_mex('record', 1.5);
torsio_mex('close');
printf('the knob was pushed to %.3f rad, into a wall at 0.1 rad,\n', max(log(:, 2)));
printf('which pushed back with %.0f mN m\n', 1e3 * max(-log(:, 3)));
