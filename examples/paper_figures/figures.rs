//! The figures: what is drawn, and what the paper leaves open.

/// A figure of the paper, or one beside it.
pub(crate) struct Figure(
    /// Name of its files.
    pub(crate) &'static str,
    /// Title.
    pub(crate) &'static str,
    /// What its commands ask for; the last one draws it, those before write tables that it reads.
    pub(crate) &'static [&'static str],
    /// What the paper leaves open, and what was chosen.
    pub(crate) &'static str,
);

pub(crate) const FIGURES: [Figure; 14] = [
    Figure(
        "fig6a",
        "Figure 6a: P_LoS against θ, urban",
        &["itu:urban --theta 5:90:5 --method city,geometry,product,itu,alhourani2014,mohammed2023 --links 1000"],
        "As in the paper: UAV at 100 m; 500 cities with 360 users on a circle; 1000 runs of the geometry simulator, which \
         leave wide error bars. Open in the paper: here users are at 0 m, those of the 360 on open ground count, and the \
         UAV is anywhere over the city, NLoS to all where it is inside a building. The formula of the paper's third \
         reference curve (ICC 2021) is not public; in its place is Mohammed 2023, the later model of its authors.",
    ),
    Figure(
        "fig6b",
        "Figure 6b: P_LoS against θ, dense urban",
        &["itu:dense-urban --theta 5:90:5 --method city,geometry,product,itu,alhourani2014,mohammed2023 --links 1000"],
        "As in figure 6a.",
    ),
    Figure(
        "fig6c",
        "Figure 6c: P_LoS against θ, high-rise",
        &["itu:high-rise --theta 5:90:5 --method city,geometry,product,itu,alhourani2014,mohammed2023 --links 1000"],
        "As in figure 6a.",
    ),
    Figure(
        "fig7",
        "Figure 7: P_LoS against distance, urban",
        &["itu:urban --distance 0:500:25 --height 50,100,200 --method city,geometry,product,mohammed2023 --links 1000"],
        "Open in the paper: the UAV's heights, here 50, 100 and 200 m, and the distances, here up to 500 m.",
    ),
    Figure(
        "fig8",
        "Figure 8: P_LoS in Ghent and in environments called similar",
        &[
            "itu:suburban --theta 5:90:1 --method product -o suburban.csv",
            "itu:dense-urban --theta 5:90:1 --method product -o dense.csv",
            "itu:dense-urban --theta 5:90:1 --method mohammed2023 -o dense-mohammed.csv",
            "itu:dense-urban --theta 5:90:1 --method holis2008 -o dense-holis.csv",
            "itu:0.435,4679,8.8 --theta 5:90:5 --method city,product,mohammed2023 --curve \"Product, dense urban=dense.csv\" \
             --curve \"Mohammed 2023, dense urban=dense-mohammed.csv\" --curve \"Holis 2008, dense urban=dense-holis.csv\" \
             --curve \"Product, suburban=suburban.csv\"",
        ],
        "Open in the paper: which environment is the most similar, here dense urban (by α) and suburban (by γ); whether \
         γ = 8.8 m is the scale of the Rayleigh distribution or a mean, here the scale. The ICC 2021 curve is replaced as \
         in figure 6a. Holis 2008 was made for platforms from 8 km up.",
    ),
    Figure(
        "fig9",
        "Figure 9: P_LoS against γ and θ",
        &["itu:urban --theta 5:90:2.5 --gamma 5:50:2.5"],
        "Open in the paper: α and β, here those of urban, and the range of γ. By the product over buildings.",
    ),
    Figure(
        "fig10",
        "Figure 10: P_LoS against α and γ, θ = 45°",
        &["itu:urban --theta 45 --alpha 0.05:0.8:0.025 --gamma 5:50:2.5"],
        "The caption in the paper repeats that of figure 9; its text names α and γ. Open there: θ, here 45°, β, here that \
         of urban, and both ranges.",
    ),
    Figure(
        "fig11",
        "Figure 11: P_LoS against θ and φ, users on the street",
        &["itu:urban --users street --theta 5:85:4 --phi 0:90:3"],
        "Open in the paper: the environment, here urban. At φ = 0 the UAV is across the user's street, at 90° along it.",
    ),
    Figure(
        "fig12",
        "Figure 12: P_LoS against θ and φ, users on the crossroad",
        &["itu:urban --users crossroad --theta 5:85:4 --phi 0:90:3"],
        "As in figure 11.",
    ),
    Figure(
        "takeaway1",
        "Beyond the paper: models and the exact value at every degree",
        &["itu:suburban itu:urban itu:dense-urban itu:high-rise --theta 1:90:1 \
           --method product,itu,alhourani2014,mohammed2023"],
        "Takeaway 1 is judged by this table. It has suburban too, which figure 6 leaves out.",
    ),
    Figure(
        "takeaway2",
        "Beyond the paper: all models that apply, dense urban and Ghent",
        &["itu:dense-urban itu:0.435,4679,8.8 --theta 5:90:5 --method product,models"],
        "Takeaway 2 is judged by this table. A model without a line refuses the city.",
    ),
    Figure(
        "takeaway3",
        "Beyond the paper: P_LoS against φ, urban, θ = 45°",
        &["itu:urban --theta 45 --phi 0:90:3 --users street,crossroad \
           --method product,itu,alhourani2014,holis2008,kang2019,mohammed2023,tr36777_uma_av,tr38811"],
        "Takeaway 3 is judged by this table and those of figures 11 and 12.",
    ),
    Figure(
        "centers",
        "Beyond the paper: the area around a UAV over the middle of a crossroad, street, building",
        &["itu:suburban itu:urban itu:dense-urban itu:high-rise --radius 50:300:10 \
           --placement crossroad-center,street-center,rooftop-center"],
        "The paper gives a reason for the crossroad and no numbers. Users are on all open ground within the radius.",
    ),
    Figure(
        "anywhere",
        "Beyond the paper: the same, UAV anywhere over a crossroad, street, building",
        &[
            "itu:suburban itu:urban itu:dense-urban itu:high-rise --radius 50:300:25 --placement crossroad,street,rooftop",
        ],
        "As in the last picture.",
    ),
];

impl Figure {
    /// The commands as they are run and shown.
    pub(crate) fn commands(&self) -> Vec<String> {
        let Figure(id, title, commands, _) = self;
        let mut lines: Vec<String> =
            commands.iter().map(|c| format!("plos {c} --rx-height 0 --overwrite --quiet")).collect();
        if let Some(last) = lines.last_mut() {
            *last += &format!(" -o {id}.png -o {id}.svg -o {id}.csv --title \"{title}\"");
        }
        lines
    }
}
