use gelpad::eit::*;
use gelpad::pad::*;
use gelpad::touch::*;
use gelpad::source::{Noise, FramesCsv, Reading, Source};
use gelpad::types::*;
use std::sync::Arc;
use std::time::Instant;
#[derive(serde::Deserialize, Clone)]
#[allow(dead_code)] struct Press { t0: f64, t1: f64, x: f64, y: f64, kind: String }
struct Track { first: f64, last: f64, n: usize, sum: [f64;2] }
fn frames(pad:&Pad)->Vec<Frame>{ let mut s=FramesCsv::open(std::path::Path::new("tests/data/lattice-presses/session.csv"), pad.channels()).unwrap(); let mut v=vec![]; while let Reading::Frame(f)=s.read().unwrap(){v.push(f);} v }
fn run(pad:&Pad, b:&SensingBuilder, frames:&[Frame], frame_ms: f64, label:&str, verbose: bool) {
    let presses: Vec<Press> = std::fs::read_to_string("tests/data/lattice-presses/session.truth.jsonl").unwrap().lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let mut d = Detector::of_pad(Arc::new(b.first().unwrap()), &pad.protocol);
    let mut tracks: std::collections::BTreeMap<u64, Track> = Default::default();
    let mut took = vec![]; let mut lost = vec![]; let mut wants = 0;
    let mut errs = vec![];
    for f in frames {
        let mut ch = vec![];
        let t = Instant::now();
        d.frame(f, &mut ch);
        took.push(t.elapsed().as_secs_f64()*1e6);
        if verbose && label=="plain" && *took.last().unwrap()>400.0 { println!("  {:.0} ms took {:.0} us, down {}: {:?}", f.t_ns as f64*1e-6, took.last().unwrap(), d.state().down.len(), d.state().down.iter().map(|t| (t.phase, t.contact.centre_mm.map(|v| v.round()), (t.contact.force*100.0).round())).collect::<Vec<_>>()); }
        let w = d.wanted().map(|w| w.to_vec());
        if let Some(w) = w { wants += 1; d.take(Arc::new(b.build(&w).unwrap())); }
        let l = d.lost_electrodes(); if l != lost { if verbose { println!("  {} ms lost {l:?}", f.t_ns as f64*1e-6); } lost = l; }
        if std::env::var("DBG").is_ok() && label=="20 fps" && (19250..19800).contains(&(f.t_ns/1_000_000)) { println!("  {} {:?}", f.t_ns/1_000_000, d.state().down.iter().map(|t| (t.id.0, t.contact.centre_mm.map(|v| v.round()), (t.contact.force*150.0).round())).collect::<Vec<_>>()); }
        for t in d.state().down {
            let ms = f.t_ns as f64*1e-6;
            let e = tracks.entry(t.id.0).or_insert(Track{first:ms,last:ms,n:0,sum:[0.0;2]});
            e.last=ms; e.n+=1; e.sum[0]+=t.contact.centre_mm[0]; e.sum[1]+=t.contact.centre_mm[1];
            if let Some(p) = presses.iter().filter(|p| p.t0*1e3<=ms && ms<=p.t1*1e3).map(|p| (p.x-t.contact.centre_mm[0]).hypot(p.y-t.contact.centre_mm[1])).min_by(|a,b| a.total_cmp(b)) { errs.push(p); }
        }
    }
    let mut found=0; let mut split=0; let mut worst_len=0f64; let mut late=0f64; let mut worst_mm=0f64; let mut used=std::collections::BTreeSet::new(); let mut longest=vec![];
    for p in &presses {
        let c: Vec<_> = tracks.iter().filter(|(_,t)| t.first < p.t1*1e3+1.5*frame_ms && t.last > p.t0*1e3 - 1.5*frame_ms && (t.sum[0]/t.n as f64-p.x).hypot(t.sum[1]/t.n as f64-p.y)<10.0).collect();
        if c.is_empty() { if verbose { println!("  missed {} {:.0}..{:.0} at {:.0} {:.0}", p.kind, p.t0*1e3, p.t1*1e3, p.x, p.y); } continue; }
        found+=1; if c.len()>1 { split+=1; if verbose { println!("  split {} {:.0}..{:.0}: {:?}", p.kind, p.t0*1e3, p.t1*1e3, c.iter().map(|(i,t)| (**i,t.first,t.last)).collect::<Vec<_>>()); } }
        for (i,_) in &c { used.insert(**i); }
        let t=c[0].1; let len=(t.last-t.first+frame_ms)-(p.t1-p.t0)*1e3; longest.push(len);
        if verbose && len.abs() > frame_ms { println!("  length {len:.1} {} {:.1}..{:.1} seen {:.0}..{:.0} at {:.0} {:.0}", p.kind, p.t0*1e3, p.t1*1e3, t.first, t.last, p.x, p.y); }
        if len.abs()>worst_len.abs() {worst_len=len;} late=late.max(t.first-p.t0*1e3); worst_mm=worst_mm.max((t.sum[0]/t.n as f64-p.x).hypot(t.sum[1]/t.n as f64-p.y));
    }
    let falses: Vec<_> = tracks.iter().filter(|(i,_)| !used.contains(i)).collect();
    if verbose { for (i,t) in &falses { println!("  false {i}: {:.0}..{:.0} at {:.1} {:.1}", t.first, t.last, t.sum[0]/t.n as f64, t.sum[1]/t.n as f64); } }
    took.sort_by(f64::total_cmp); errs.sort_by(f64::total_cmp);
    println!("{label}: found {found}/{} split {split} false {} worst length {worst_len:.1} ms late {late:.1} mm {worst_mm:.2} (frame median {:.2} p95 {:.2}) wants {wants}; frame median {:.0} p99 {:.0} max {:.0} us", presses.len(), falses.len(), errs[errs.len()/2], errs[errs.len()*95/100], took[took.len()/2], took[took.len()*99/100], took[took.len()-1]);
}
#[test]
fn session() {
    let s = shipped_pad("edinburgh-lattice").unwrap(); let pad = Pad::from_toml(s.name, s.toml).unwrap();
    let t = Instant::now();
    let table = Arc::new(gelpad::cache::table(&pad, |_,_|()).unwrap());
    println!("table {:?}", t.elapsed());
    let m = if std::env::var("NOSER").is_ok() {Method::Noser} else {Method::Tikhonov};
    let b = SensingBuilder::new(&pad, m).unwrap().with_table(table);
    let t = Instant::now(); let _ = b.build(&[vec![1e-3;200], vec![f64::INFINITY;8]].concat()).unwrap(); println!("rebuild {:?}", t.elapsed());
    let fs = frames(&pad);
    run(&pad, &b, &fs, 10.0, "plain", true);
    let mut n45 = Noise::new(45.0, 5);
    let noisy: Vec<Frame> = fs.iter().map(|f| Frame{t_ns:f.t_ns, volts: n45.read(&f.volts.iter().map(|v| *v as f64).collect::<Vec<_>>())}).collect();
    run(&pad, &b, &noisy, 10.0, "45 dB", true);
    for (label, gain) in [("drift common 10 %/min", true), ("drift own 10 %/min", false)] {
        let drift: Vec<Frame> = fs.iter().map(|f| { let s=f.t_ns as f64*1e-9; Frame{t_ns:f.t_ns, volts: f.volts.iter().enumerate().map(|(c,v)| { let k = if gain {1.0} else { ((c*7919)%208) as f64/104.0-1.0 }; (*v as f64*(1.0+0.1/60.0*s*k)) as f32 }).collect()} }).collect();
        run(&pad, &b, &drift, 10.0, label, true);
    }
    for k in [3usize,4,6,7,8] { let thin: Vec<Frame> = fs.iter().step_by(k).cloned().collect(); run(&pad, &b, &thin, 10.0*k as f64, &format!("{} fps", 100/k), true); }
    for off in 1..5 { let thin: Vec<Frame> = fs.iter().skip(off).step_by(5).cloned().collect(); run(&pad, &b, &thin, 50.0, &format!("20+{off} fps"), true); }
    for k in [2usize,5,10] { let thin: Vec<Frame> = fs.iter().step_by(k).cloned().collect(); run(&pad, &b, &thin, 10.0*k as f64, &format!("{} fps", 100/k), true); }
    let full = fs[0].volts.iter().fold(0f32, |m,v| m.max(v.abs())) as f64;
    for e in [2usize, 5, 9, 13] {
        let mut rnd = Noise::new(0.0, 100+e as u64); // v(1+n): n ~ N(0,1) on full scale
        let half: Vec<Frame> = fs.iter().map(|f| { let mut v=f.volts.clone(); if f.t_ns>15_000_000_000 { let z=rnd.read(&vec![full; 208]); for (c,ch) in pad.protocol.channels.iter().enumerate() { if [ch.drive.0,ch.drive.1,ch.measure.0,ch.measure.1].contains(&e) { v[c]=z[c]-full as f32; } } } Frame{t_ns:f.t_ns, volts:v} }).collect();
        run(&pad, &b, &half, 10.0, &format!("electrode {e}"), true);
    }
}
