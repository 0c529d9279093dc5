// How states and detectors look: never told by colour alone.

export const STATES = {
  normal: {word: 'normal', sign: '✓', width: 2.5, dash: []},
  suspicious: {word: 'suspicious', sign: '▲', width: 5, dash: [10, 5]},
  alarm: {word: 'alarm', sign: '✖', width: 5, dash: [], crosses: true},
  degraded: {word: 'degraded', sign: '◧', width: 3, dash: [14, 4, 2, 4]},
  not_observable: {word: 'cannot tell', sign: '?', width: 3, dash: [2, 5]},
  not_ready: {word: 'not ready', sign: '…', width: 2, dash: [2, 5]},
  stale: {word: 'stopped', sign: '∅', width: 2, dash: [6, 8]},
  silent: {word: 'silent', sign: '∅', width: 2, dash: [6, 8]},
};
const DASHES = [[], [7, 3], [2, 3], [9, 3, 2, 3]];
const ALIKE = {stale: 'silent'};

let read = null;
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { read = null; });

export function colour(name) {
  read ??= new Map();
  if (!read.has(name))
    read.set(name, getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim());
  return read.get(name);
}

export const stateColour = state => colour('s-' + (ALIKE[state] ?? state));
export const detectorLine = index =>
  ({colour: colour('d-' + index % 8), dash: DASHES[index % DASHES.length]});

// A canvas in CSS pixels that is sharp on any screen, empty.
export function fresh(canvas) {
  const scale = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  const across = Math.round(width * scale), down = Math.round(height * scale);
  if (canvas.width !== across || canvas.height !== down)
    Object.assign(canvas, {width: across, height: down});
  const pen = canvas.getContext('2d');
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = '12px system-ui, sans-serif';
  pen.lineJoin = pen.lineCap = 'round';
  return {pen, width, height};
}

export function line(pen, points, hue, width, dash) {
  pen.strokeStyle = hue;
  pen.lineWidth = width;
  pen.lineCap = dash.length ? 'butt' : 'round';
  pen.setLineDash(dash);
  pen.beginPath();
  let down = false;
  for (const point of points) {
    if (point === null) down = false;
    else if (down) pen.lineTo(point[0], point[1]);
    else { pen.moveTo(point[0], point[1]); down = true; }
  }
  pen.stroke();
  pen.setLineDash([]);
}

// Crosses along a path, so many pixels apart.
export function crosses(pen, points, hue, apart = 24) {
  pen.strokeStyle = hue;
  pen.lineWidth = 2.5;
  pen.beginPath();
  let last = null;
  for (const point of points) {
    if (point === null) continue;
    if (last && Math.hypot(point[0] - last[0], point[1] - last[1]) < apart) continue;
    last = point;
    const [x, y] = point;
    pen.moveTo(x - 6, y - 6); pen.lineTo(x + 6, y + 6);
    pen.moveTo(x - 6, y + 6); pen.lineTo(x + 6, y - 6);
  }
  pen.stroke();
}

export function minutes(seconds, digits = 0) {
  const sign = seconds < 0 ? '−' : '', all = Math.abs(seconds);
  const rest = (all % 60).toFixed(digits);
  if (Number(rest) >= 60) return sign + (Math.floor(all / 60) + 1) + ':' + (0).toFixed(digits)
    .padStart(digits ? 3 + digits : 2, '0');
  return sign + Math.floor(all / 60) + ':' + rest.padStart(digits ? 3 + digits : 2, '0');
}

export function step(span, most) {
  const rough = span / most, ten = 10 ** Math.floor(Math.log10(rough));
  return ten * [1, 2, 5, 10].find(one => one * ten >= rough);
}
