// The track in metres East and North, equal axes, drawn in the style of what was said.
import {STATES, colour, crosses, fresh, line, stateColour, step} from './style.js';

const LEAST_M = 30, PAD = 0.12, MARGIN = {left: 46, right: 12, top: 8, bottom: 34};
let view = null;

// The square around all points; moves only when it must, so that the map does not tremble.
function look(points) {
  let west = Infinity, east = -Infinity, south = Infinity, north = -Infinity;
  for (const point of points) {
    if (point.length < 3) continue;
    west = Math.min(west, point[1]); east = Math.max(east, point[1]);
    south = Math.min(south, point[2]); north = Math.max(north, point[2]);
  }
  if (west > east) return view = null;
  const span = Math.max(east - west, north - south, LEAST_M), edge = 0.04 * span;
  const inside = view && west - edge >= view.west && east + edge <= view.east &&
    south - edge >= view.south && north + edge <= view.north;
  if (inside && Math.max(view.east - view.west, view.north - view.south) < 3 * span) return view;
  const room = PAD * span, wide = Math.max(0, LEAST_M - (east - west)) / 2;
  const high = Math.max(0, LEAST_M - (north - south)) / 2;
  return view = {west: west - room - wide, east: east + room + wide,
    south: south - room - high, north: north + room + high};
}

// Stretches of the track with the state that held in each: [state, points].
export function stretches(track, states) {
  const found = [];
  let at = 0;
  for (const point of track) {
    while (at + 1 < states.length && states[at + 1][0] <= point[0]) at++;
    const state = states.length ? states[at][1] : 'not_ready';
    const last = found.at(-1);
    if (last && last[0] === state) last[1].push(point);
    else found.push([state, last ? [last[1].at(-1), point] : [point]]);
  }
  return found;
}

export function drawMap(canvas, {track, states, position}) {
  const {pen, width, height} = fresh(canvas);
  const seen = look(track);
  if (!seen) {
    pen.fillStyle = colour('soft');
    pen.textAlign = 'center';
    pen.fillText('no position yet', width / 2, height / 2);
    return;
  }
  const across = width - MARGIN.left - MARGIN.right, down = height - MARGIN.top - MARGIN.bottom;
  const scale = Math.min(across / (seen.east - seen.west), down / (seen.north - seen.south));
  const middle = [(seen.east + seen.west) / 2, (seen.north + seen.south) / 2];
  const place = (east, north) => [
    MARGIN.left + across / 2 + (east - middle[0]) * scale,
    MARGIN.top + down / 2 - (north - middle[1]) * scale];
  grid(pen, place, scale, middle, across, down);
  pen.save();
  pen.beginPath();
  pen.rect(MARGIN.left, MARGIN.top, across, down);
  pen.clip();
  for (const [state, points] of stretches(track, states)) {
    const look = STATES[state] ?? STATES.silent, hue = stateColour(state);
    const path = points.map(one => one.length < 3 ? null : place(one[1], one[2]));
    line(pen, path, hue, look.width, look.dash);
    if (look.crosses) crosses(pen, path, hue);
  }
  const first = track.find(one => one.length === 3);
  if (first) start(pen, place(first[1], first[2]));
  if (position) here(pen, place(position.east, position.north));
  pen.restore();
}

function grid(pen, place, scale, middle, across, down) {
  const every = step(across / scale, across / 70), {left, top} = MARGIN;
  pen.strokeStyle = colour('grid');
  pen.fillStyle = colour('soft');
  pen.lineWidth = 1;
  pen.beginPath();
  const label = value => String(Number(value.toPrecision(12))).replace('-', '−');
  pen.textAlign = 'center';
  pen.textBaseline = 'top';
  const half = [across / scale / 2, down / scale / 2];
  for (let k = Math.ceil((middle[0] - half[0]) / every); k * every <= middle[0] + half[0]; k++) {
    const [x] = place(k * every, 0);
    pen.moveTo(x, top); pen.lineTo(x, top + down);
    if (x < left + across - 12) pen.fillText(label(k * every), x, top + down + 4);
  }
  pen.textAlign = 'right';
  pen.textBaseline = 'middle';
  for (let k = Math.ceil((middle[1] - half[1]) / every); k * every <= middle[1] + half[1]; k++) {
    const [, y] = place(0, k * every);
    pen.moveTo(left, y); pen.lineTo(left + across, y);
    if (y > top + 8) pen.fillText(label(k * every), left - 6, y);
  }
  pen.stroke();
  pen.strokeStyle = colour('line');
  pen.strokeRect(left, top, across, down);
  pen.textBaseline = 'alphabetic';
  pen.textAlign = 'right';
  pen.fillText('East, m', left + across, top + down + 31);
  pen.textAlign = 'left';
  pen.fillText('North, m', left + 6, top + 15);
  bar(pen, left, top + down, every, scale);
}

function bar(pen, left, bottom, every, scale) {
  const long = every * scale, x = left + 12, y = bottom - 12;
  pen.strokeStyle = colour('ink');
  pen.fillStyle = colour('ink');
  pen.lineWidth = 2;
  pen.beginPath();
  pen.moveTo(x, y - 5); pen.lineTo(x, y); pen.lineTo(x + long, y); pen.lineTo(x + long, y - 5);
  pen.stroke();
  pen.textAlign = 'center';
  pen.fillText(every >= 1000 ? every / 1000 + ' km' : every + ' m', x + long / 2, y - 6);
}

function start(pen, [x, y]) {
  pen.fillStyle = colour('card');
  pen.strokeStyle = colour('ink');
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.rect(x - 4, y - 4, 8, 8);
  pen.fill(); pen.stroke();
}

function here(pen, [x, y]) {
  pen.lineWidth = 3;
  pen.strokeStyle = colour('ink');
  pen.fillStyle = colour('card');
  pen.beginPath();
  pen.arc(x, y, 8, 0, 7);
  pen.fill(); pen.stroke();
  pen.fillStyle = colour('ink');
  pen.beginPath();
  pen.arc(x, y, 3, 0, 7);
  pen.fill();
}
