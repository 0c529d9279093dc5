// The margins of all detectors over the last minutes: logarithmic, clipped, the limit at 1.
import {STATES, colour, detectorLine, fresh, line, minutes, stateColour, step} from './style.js';

const LOW = 0.05, HIGH = 20, TICKS = [0.1, 0.2, 0.5, 1, 2, 5, 10], WINDOW_S = 240;
const MARGIN = {left: 38, right: 140, top: 8, bottom: 38}, RIBBON = 14, ROW = 15;

export function drawMargins(canvas, {margins, states, detectors, time}) {
  const {pen, width, height} = fresh(canvas);
  const {left, top} = MARGIN, across = width - left - MARGIN.right;
  const down = height - top - MARGIN.bottom;
  const end = Math.max(time ?? 0, 1);
  const begin = Math.max(0, end - WINDOW_S), span = Math.max(end - begin, 20);
  const x = second => left + across * (second - begin) / span;
  const y = value => {
    const part = Math.log(Math.min(HIGH, Math.max(LOW, value)) / LOW) / Math.log(HIGH / LOW);
    return top + down * (1 - part);
  };
  axes(pen, {x, y, begin, span, across, down});
  ribbon(pen, {states, x, begin, end, y: top + down + 2});
  pen.save();
  pen.beginPath();
  pen.rect(left, top - 2, across, down + 4);
  pen.clip();
  const names = detectors.map(one => one.name);
  names.forEach((name, index) => {
    const look = detectorLine(index), path = curve(margins[name] ?? [], detectors[index], begin);
    line(pen, path.map(one => one && [x(one[0]), y(one[1])]), look.colour, 2, look.dash);
  });
  pen.restore();
  labels(pen, detectors, y, left + across + 6, top, top + down);
}

function curve(points, now, begin) {
  let first = points.findIndex(one => one[0] >= begin);
  if (first < 0) first = points.length;
  const path = points.slice(Math.max(0, first - 1)).map(one => one[1] === null ? null : one);
  if (now.margin !== null && now.time !== undefined) path.push([now.time, now.margin]);
  return path;
}

function axes(pen, {x, y, begin, span, across, down}) {
  const {left, top} = MARGIN;
  pen.fillStyle = colour('limit');
  pen.globalAlpha = 0.08;
  pen.fillRect(left, top, across, y(1) - top);
  pen.globalAlpha = 1;
  pen.lineWidth = 1;
  pen.strokeStyle = colour('grid');
  pen.fillStyle = colour('soft');
  pen.textAlign = 'right';
  pen.textBaseline = 'middle';
  pen.beginPath();
  for (const tick of TICKS) {
    pen.moveTo(left, y(tick)); pen.lineTo(left + across, y(tick));
    pen.fillText(String(tick), left - 6, y(tick));
  }
  pen.textAlign = 'center';
  pen.textBaseline = 'top';
  const every = [5, 10, 20, 30, 60].find(one => span / one <= across / 64) ?? 120;
  for (let k = Math.ceil(begin / every); k * every <= begin + span; k++) {
    pen.moveTo(x(k * every), top); pen.lineTo(x(k * every), top + down);
    pen.fillText(minutes(k * every), x(k * every), top + down + RIBBON + 6);
  }
  pen.stroke();
  pen.strokeStyle = colour('line');
  pen.strokeRect(left, top, across, down);
  line(pen, [[left, y(1)], [left + across, y(1)]], colour('limit'), 2, []);
  pen.fillStyle = colour('limit');
  pen.textAlign = 'left';
  pen.textBaseline = 'bottom';
  pen.fillText('limit', left + 6, y(1) - 3);
}

// What the monitor said, under the curves, in words where there is room.
function ribbon(pen, {states, x, begin, end, y}) {
  pen.textAlign = 'left';
  pen.textBaseline = 'middle';
  states.forEach(([from, state], index) => {
    const until = Math.min(end, states[index + 1]?.[0] ?? end);
    if (until <= begin) return;
    const at = x(Math.max(from, begin)), wide = x(until) - at;
    pen.fillStyle = stateColour(state);
    pen.fillRect(at, y, Math.max(wide, 1), RIBBON);
    const word = (STATES[state] ?? STATES.silent).word;
    if (pen.measureText(word).width + 8 > wide) return;
    pen.fillStyle = colour('card');
    pen.fillText(word, at + 4, y + RIBBON / 2 + 1);
  });
}

// Names and values at the right end, beside their lines, moved apart.
function labels(pen, detectors, y, x, top, bottom) {
  const shown = detectors.map((one, index) => ({...one, index}))
    .filter(one => one.margin !== null)
    .map(one => ({...one, want: y(one.margin)}))
    .sort((a, b) => a.want - b.want);
  let at = top;
  for (const one of shown) { one.at = Math.max(one.want, at); at = one.at + ROW; }
  at = bottom;
  for (const one of [...shown].reverse()) { one.at = Math.min(one.at, at); at = one.at - ROW; }
  pen.textAlign = 'left';
  pen.textBaseline = 'middle';
  for (const one of shown) {
    const look = detectorLine(one.index);
    line(pen, [[x, one.at], [x + 22, one.at]], look.colour, 2.5, look.dash);
    pen.fillStyle = colour('ink');
    pen.font = (one.margin >= 1 ? '700 ' : '') + '12px system-ui, sans-serif';
    pen.fillText(`${one.name} ${one.margin.toFixed(2)}`, x + 27, one.at);
  }
}
