use gelpad::eit::*;
use gelpad::eit::response::*;
use gelpad::pad::*;
use gelpad::touch::Locator;
use gelpad::source::Noise;
use std::time::Instant;
use std::sync::Arc;
fn norm(a:&[f64])->f64{a.iter().map(|x|x*x).sum::<f64>().sqrt()}
fn table(pad:&Pad)->Arc<ResponseTable>{
    let path = format!("/tmp/t/{}.resp2", pad.name);
    if let Ok(b) = std::fs::read(&path) { if let Ok(t) = ResponseTable::from_bytes(&b) { if t.key()==ResponseBuilder::key(pad) { return Arc::new(t); } } }
    let t = Instant::now();
    let b = ResponseBuilder::new(pad).unwrap();
    let rows: Vec<ResponseRow> = std::thread::scope(|s| {
        let b=&b; let n=b.rows();
        let h: Vec<_> = (0..2).map(|k| s.spawn(move || (k..n).step_by(2).map(|r| (r, b.solve_row(r))).collect::<Vec<_>>())).collect();
        let mut all: Vec<_> = h.into_iter().flat_map(|h| h.join().unwrap()).collect();
        all.sort_by_key(|r| r.0); all.into_iter().map(|r| r.1).collect()
    });
    let table = b.finish(&rows);
    println!("table in {:?} rank {}", t.elapsed(), table.rank());
    std::fs::write(path, table.to_bytes()).unwrap();
    Arc::new(table)
}
fn pad()->Pad{ let s = shipped_pad("edinburgh-lattice").unwrap(); Pad::from_toml(s.name, s.toml).unwrap() }
#[test]
fn faint() {
    // every single touch of static.csv at 40 dB, held for 12 frames: in which frame is it found?
    let pad = pad();
    let table = Arc::new(gelpad::cache::table(&pad, |_,_|()).unwrap());
    let b = gelpad::touch::SensingBuilder::new(&pad, gelpad::types::Method::Noser).unwrap().with_table(table);
    let rows: Vec<Vec<f64>> = csv::Reader::from_path("tests/data/lattice-presses/static.csv").unwrap().deserialize().map(|r| { let r: Vec<f64> = r.unwrap(); r[1..].to_vec() }).collect();
    for seed in [1,2,3] {
        let mut noise = Noise::new(40.0, seed);
        let mut d0 = gelpad::touch::Detector::of_pad(Arc::new(b.first().unwrap()), &pad.protocol);
        let mut ch=vec![]; let mut t=0u64; let mut frame=|v:&Vec<f64>, n:&mut Noise| { t+=10_000_000; gelpad::types::Frame{t_ns:t, volts:n.read(v)} };
        for _ in 0..200 { d0.frame(&frame(&rows[0],&mut noise), &mut ch); }
        println!("quiet: {} touches in 200 frames", ch.len());
        let mut hist=[0;14]; let mut flick=0;
        for v in &rows[1..101] { let mut d=d0.clone(); let mut at=13; let mut ups=0; for k in 0..12 { let mut ch=vec![]; d.frame(&frame(v,&mut noise),&mut ch); if at==13 && !d.state().down.is_empty() {at=k;} ups+=ch.iter().filter(|t| t.phase==gelpad::types::Phase::Up).count(); } hist[at]+=1; if ups>0 {flick+=1;} }
        println!("found in frame {hist:?}, with gaps {flick}");
        let mut quiet=0; let mut d=d0.clone(); for _ in 0..6000 { let mut ch=vec![]; d.frame(&frame(&rows[0],&mut noise),&mut ch); quiet+=ch.len(); } println!("6000 untouched frames: {quiet} changes");
    }
}
#[test]
fn statics() {
    let pad = pad();
    let table = Arc::new(gelpad::cache::table(&pad, |_,_|()).unwrap());
    let rows: Vec<Vec<f64>> = csv::Reader::from_path("tests/data/lattice-presses/static.csv").unwrap().deserialize().map(|r| { let r: Vec<f64> = r.unwrap(); r[1..].to_vec() }).collect();
    let truth: Vec<Vec<[f64;4]>> = std::fs::read_to_string("tests/data/lattice-presses/static.truth.jsonl").unwrap().lines().map(|l| {
        let v: serde_json::Value = serde_json::from_str(l).unwrap();
        v["touches"].as_array().unwrap().iter().map(|t| [t["x_mm"].as_f64().unwrap(), t["y_mm"].as_f64().unwrap(), t["r_mm"].as_f64().unwrap(), t["rise"].as_f64().unwrap()]).collect()
    }).collect();
    for snr in [60.0, 40.0] { for seed in [1,2,3] {
        let mut noise = Noise::new(snr, seed);
        let mut v0 = vec![0.0; 208];
        for _ in 0..10 { for (a,b) in v0.iter_mut().zip(noise.read(&rows[0])) { *a += b as f64/10.0; } }
        let sigma = 10f64.powf(-snr/20.0);
        let fresh = Locator::new(&gelpad::touch::Locating::new(table.clone(), &pad.outline, &vec![sigma; 208]));
        let mut errs: [Vec<f64>;3] = Default::default(); let mut right=[0;3]; let mut missed=[0;3]; let mut time=[0.0;3];
        let mut ferr = vec![];
        for (k,(v,t)) in rows.iter().zip(&truth).enumerate().skip(1) {
            let d: Vec<f32> = noise.read(v).iter().zip(&v0).map(|(a,b)| ((*a as f64-b)/b) as f32).collect();
            let mut l = fresh.clone();
            let now = Instant::now();
            l.take_frame(&d, 1.1); let e = l.locate(1.1, 0.1);
            time[t.len()-1] += now.elapsed().as_secs_f64()*1e6/100.0;
            let c: Vec<_> = l.contacts().collect();
            let n = t.len()-1;
            let mut worst = 0.0f64;
            for p in t {
                let m = c.iter().map(|c| (c.centre_mm[0]-p[0]).hypot(c.centre_mm[1]-p[1])).fold(f64::INFINITY, f64::min);
                if m>10.0 { missed[n]+=1; } else { errs[n].push(m); }
                worst = worst.max(m);
                if let Some(c)=c.iter().find(|c| (c.centre_mm[0]-p[0]).hypot(c.centre_mm[1]-p[1])<5.0) { let f=p[3]*p[2]*p[2]*std::f64::consts::FRAC_PI_2/150.0; if f<1.0 {ferr.push((c.force-f)/f);} }
            }
            if c.len()==t.len() { right[n]+=1; }
            if (snr==60.0 || t.len()==1 && worst>5.0) && (c.len()!=t.len() || worst>1.2) {
                println!("frame {k}: truth {t:.1?} -> {:?} e {e:.2?}", l.bumps().iter().map(|b| [b.centre_mm[0],b.centre_mm[1],b.log_radius.exp(),b.rise()].map(|v| (v*10.0).round()/10.0)).collect::<Vec<_>>());
            }
        }
        for n in 0..3 { errs[n].sort_by(f64::total_cmp); let e=&errs[n]; println!("{snr} dB seed {seed} n {} mean {:.3} median {:.3} p95 {:.3} max {:.2} right {} missed {} time {:.0} us", n+1, e.iter().sum::<f64>()/e.len() as f64, e[e.len()/2], e[e.len()*95/100], e[e.len()-1], right[n], missed[n], time[n]); }
        ferr.sort_by(f64::total_cmp); println!("force error median {:.3} 5% {:.3} 95% {:.3}", ferr[ferr.len()/2], ferr[ferr.len()/20], ferr[ferr.len()*19/20]);
    } }
    let _ = norm(&[]);
}
